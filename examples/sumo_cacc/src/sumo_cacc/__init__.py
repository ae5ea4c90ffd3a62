"""A platoon in SUMO whose followers drive by what their local dynamic maps believe."""
