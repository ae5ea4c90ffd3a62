"""What messages and models are worth to platoons that drive by them."""
