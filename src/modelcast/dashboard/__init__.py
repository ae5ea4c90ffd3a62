"""The page that one looks at: what a host believes, as a live map in a browser.

`snapshot` says what is shown at one time and builds it from a station; `document` writes and reads it as
JSON. A feed (`feed`: live; `log`: recorded) gives snapshots to `server`, which serves the page and nothing
else, behind `gate`. `demo` is a feed to try it with.
"""
