(nc-jump-target)
GOTO 500
