(nc-unsupported-word)
#<a>=1
