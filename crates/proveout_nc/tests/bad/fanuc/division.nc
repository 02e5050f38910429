(nc-arithmetic)
#1=1/0
