(nc-loop-limit)
N1 #1=1
GOTO 1
