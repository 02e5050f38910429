(nc-syntax)
G0 X1. (OPEN
