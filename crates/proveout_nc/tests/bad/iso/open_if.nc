(nc-syntax)
IF [1 EQ 1]
