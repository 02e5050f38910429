(nc-syntax)
G0 X[1+2
