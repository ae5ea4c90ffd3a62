"""Members, banks and rules side by side on trips that none of them was trained on."""
