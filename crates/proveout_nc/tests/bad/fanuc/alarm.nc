(nc-program-alarm)
G0 X0
#3000=12 (WRONG TOOL)
