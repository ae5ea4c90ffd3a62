"""A station on the road: a real clock, sources, sockets, recordings and the page one looks at."""
