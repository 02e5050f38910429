(nc-unknown-word)
G999 X1.
