; a pocket of 60 x 40 mm with round corners, climb-milled: mm, absolute
G21 G90 G17
G0 X-30 Y-10 Z20
G0 Z0
G1 X-30 Y10 F600
G2 X-20 Y20 I10 J0
G1 X20 Y20
G2 X30 Y10 I0 J-10
G1 X30 Y-10
G2 X20 Y-20 I-10 J0
G1 X-20 Y-20
G2 X-30 Y-10 I0 J10
G0 Z20
