(nc-unsupported-word)
G51 X0 Y0 P2000
