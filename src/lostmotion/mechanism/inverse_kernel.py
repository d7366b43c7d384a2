"""Compiled forward kinematics: pose of the tool and its Jacobian at many poses, for inverse
kinematics.
"""

from __future__ import annotations

import numpy as np

from lostmotion.compiled import compiled


@compiled
def write_tool_and_jacobian(q, fixed, turning, sliding, frame, jacobian):
    """Write the pose of the tool to `frame` (pose, 4, 4), m, and its twist per motion of each joint
    to `jacobian` (pose, 6, joint), base axes.

    q                 (pose, joint) rad or m
    fixed             (joint + 1, 4, 4) pose of each moving joint relative to the previous one, from
                      the base to the tool, m
    turning, sliding  (joint, 3) unit axes in the joint's own frame; one of the two is zero
    """
    here, turned, step, place, about = (
        np.empty((3, 4)),
        np.empty((3, 4)),
        np.empty((3, 3)),
        np.empty((q.shape[1], 3)),
        np.empty(3),
    )
    for p in range(q.shape[0]):
        for i in range(3):
            for k in range(4):
                here[i, k] = fixed[0, i, k]
        for j in range(q.shape[1]):
            w, v, value = turning[j], sliding[j], q[p, j]
            s, c = np.sin(value), 1 - np.cos(value)
            for i in range(3):
                for k in range(3):
                    step[i, k] = c * w[i] * w[k]
                step[i, i] += 1 - c * (w[0] * w[0] + w[1] * w[1] + w[2] * w[2])
            step[0, 1] -= s * w[2]
            step[0, 2] += s * w[1]
            step[1, 0] += s * w[2]
            step[1, 2] -= s * w[0]
            step[2, 0] -= s * w[1]
            step[2, 1] += s * w[0]
            for i in range(3):
                jacobian[p, i, j] = here[i, 0] * w[0] + here[i, 1] * w[1] + here[i, 2] * w[2]
                jacobian[p, 3 + i, j] = here[i, 0] * v[0] + here[i, 1] * v[1] + here[i, 2] * v[2]
                here[i, 3] += jacobian[p, 3 + i, j] * value
                place[j, i] = here[i, 3]
            _compose(here, step, turned)
            _multiply(turned, fixed[j + 1], here)
        for i in range(3):
            for k in range(4):
                frame[p, i, k] = here[i, k]
            frame[p, 3, i] = 0.0
        frame[p, 3, 3] = 1.0
        for j in range(q.shape[1]):
            for i in range(3):
                about[i] = here[i, 3] - place[j, i]
            for i in range(3):
                a, b = (i + 1) % 3, (i + 2) % 3
                jacobian[p, 3 + i, j] += jacobian[p, a, j] * about[b] - jacobian[p, b, j] * about[a]


@compiled
def _compose(here, turn, out):
    """Write to `out` a frame (3, 4) rotated by `turn` (3, 3) about its own origin."""
    for i in range(3):
        for k in range(3):
            out[i, k] = here[i, 0] * turn[0, k] + here[i, 1] * turn[1, k] + here[i, 2] * turn[2, k]
        out[i, 3] = here[i, 3]


@compiled
def _multiply(here, pose, out):
    """Write to `out` the product of a frame (3, 4) and a pose (4, 4)."""
    for i in range(3):
        for k in range(4):
            out[i, k] = here[i, 0] * pose[0, k] + here[i, 1] * pose[1, k] + here[i, 2] * pose[2, k]
        out[i, 3] += here[i, 3]
