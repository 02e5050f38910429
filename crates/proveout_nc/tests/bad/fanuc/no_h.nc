(nc-missing-value)
G43 Z10.
