(nc-program-alarm)
#3000=1(TOOL TOO SHORT)
M30
