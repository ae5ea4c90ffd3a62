"""What messages and models are worth to safety applications."""
