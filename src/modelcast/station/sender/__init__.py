"""What a station sends: when, which message, with which sub-model, in how many bytes."""
