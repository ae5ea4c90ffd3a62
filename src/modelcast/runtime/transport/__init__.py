"""How frames leave a station and reach another, whatever is below."""
