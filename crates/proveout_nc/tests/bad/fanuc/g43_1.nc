(nc-unsupported-word)
G43.1 H1
