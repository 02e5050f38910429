(nc-unsupported-word)
G0 X#5061
