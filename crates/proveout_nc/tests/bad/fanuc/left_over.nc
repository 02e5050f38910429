(nc-unknown-word)
G0 X1. Q5.
