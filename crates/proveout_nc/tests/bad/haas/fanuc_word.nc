(nc-unknown-word)
G68.2 X0
