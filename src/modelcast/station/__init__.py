"""A vehicle, a person or a roadside unit: what it senses, sends, hears and believes."""
