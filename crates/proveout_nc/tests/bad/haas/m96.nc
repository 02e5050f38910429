(nc-unsupported-word)
M96 P100 Q4
