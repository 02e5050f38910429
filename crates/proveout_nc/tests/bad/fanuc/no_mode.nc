(nc-missing-value)
X10. Y10.
