"""What the words of an ISO 9283 sheet mean, for whoever reads it without the standard."""

from __future__ import annotations

from typing import Final

WORDS: Final = (
    (
        "predicted, never certified",
        (
            "characteristics by the definitions of ISO 9283:1998, for simulated robots of this "
            "design; a certificate needs the robot itself."
        ),
    ),
    (
        "AP_p",
        (
            "pose accuracy: distance of the barycentre (the mean of a robot's visits) from the "
            "commanded point (7.2.1)."
        ),
    ),
    (
        "best-fit frames",
        (
            "AP_p after a least-squares fit of the base frame (and of the tool frame, where "
            "orientations were measured)."
        ),
    ),
    (
        "RP_l",
        (
            "pose repeatability: mean distance of the visits from their barycentre plus three "
            "standard deviations of it (7.2.2)."
        ),
    ),
    (
        "thirty visits",
        (
            "RP_l of 30 visits is a sample estimate: for isotropic normal scatter mean 3.536 "
            "sigma, standard deviation 0.329; 3.616 for many visits."
        ),
    ),
    (
        "none described",
        (
            "no described error varies from visit to visit: no repeatability is predicted, which "
            "does not mean that it is zero."
        ),
    ),
    (
        "from either side",
        (
            "RP_l if joints arrive from either side at random, so that all backlash counts. In "
            "the standard's cycle each arrives from one."
        ),
    ),
    (
        "mean, 95th percentile",
        "over the simulated robots; at full payload where no load is stated.",
    ),
    ("worst", "the worst of the five poses of each robot."),
    ("a, b, c", "rotations about the base's x, y, z axes."),
    (
        "vAP_p",
        (
            "multi-directional pose accuracy: largest distance between the barycentres of "
            "approaches along the base's x, y and z (7.2.3)."
        ),
    ),
    (
        "positioning by axis",
        "ISO 230-2 along and about one axis at a time, as makers of positioners state it.",
    ),
    (
        "A, R, B, E, M",
        (
            "ISO 230-2: range of mean ± two standard deviations over all positions (A) and at the "
            "worst (R); B is the difference of the sides."
        ),
    ),
    ("AD_p, RD", "accuracy and repeatability of the distance between P2 and P4 (7.3)."),
    (
        "AT_p, RT_p",
        (
            "path accuracy and repeatability, normal to the path, at its worst point (8.2, 8.3); "
            "AT_a to RT_c of its orientation. Quasi-static."
        ),
    ),
    ("100 %, 10 %", "share of the payload that the tool carries."),
    (
        "interval",
        "95 % confidence interval from the number of robots. A question mark: too few robots.",
    ),
)
