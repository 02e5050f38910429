(nc-conflicting-words)
G0 X1. X2.
