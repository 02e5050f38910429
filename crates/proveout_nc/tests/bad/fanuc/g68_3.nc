(nc-unsupported-word)
G68.3 X0 Y0 Z0 R0
