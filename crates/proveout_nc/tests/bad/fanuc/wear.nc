(nc-unsupported-word)
G10 L11 P1 R0.1
