(nc-arguments)
G65 P1 I1. I1. I1. I1. I1. I1. I1. I1. I1. I1. I1.
