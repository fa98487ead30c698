"""What moves the tip by one centimetre, by which motions of unlike units are made comparable."""

JOINT_CENTIMETRE = (0.02, 0.01, 0.042)
"""Displacement of each joint that moves the tip by about 1 cm [rad, m, rad], from 0.5 m and a_3 = 0.24 m."""

POSITION_CENTIMETRE = (0.01, 0.01, 0.01)
"""1 cm along each axis [m]."""

ANGLE_CENTIMETRE = JOINT_CENTIMETRE[2]
"""Rotation of the last link that moves the tip by 1 cm [rad]."""
