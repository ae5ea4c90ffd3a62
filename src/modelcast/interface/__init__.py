"""What a Python user calls: trips in any form in, results with frames, figures and files out."""
