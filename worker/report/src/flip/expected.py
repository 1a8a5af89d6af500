"""Prints what the authors' program finds for the pictures of `tests.rs`.

    python3 -m venv target/python
    target/python/bin/pip install flip-evaluator==1.7 numpy==2.4.6
    target/python/bin/python worker/report/src/flip/expected.py
"""

import flip_evaluator
import numpy

WIDTH, HEIGHT = 96, 64


def noise(number):
    """The same 24 bits as `noise` in tests.rs, as 0 to 1."""
    x = (number * 2654435761) & 0xFFFFFFFF
    x ^= x >> 15
    x = (x * 2246822519) & 0xFFFFFFFF
    x ^= x >> 13
    return (x >> 8) / 16777216.0


def reference(x, y, c):
    base = [x / WIDTH, y / HEIGHT, 0.25][c]
    if (x // 12 + y // 12) % 2 == 0:
        base *= 0.2
    return base * (40.0 if 60 <= x < 70 and 20 <= y < 26 else 1.0)


def picture(kind):
    out = numpy.zeros((HEIGHT, WIDTH, 3), numpy.float32)
    for y in range(HEIGHT):
        for x in range(WIDTH):
            for c in range(3):
                r = reference(x, y, c)
                n = noise((y * WIDTH + x) * 3 + c)
                if kind == "noisy":
                    r *= 0.5 + n
                elif kind == "shifted":
                    r = reference(max(x - 2, 0), y, c)
                elif kind == "tinted":
                    r *= [1.1, 1.0, 0.8][c]
                elif kind == "fireflies" and n > 0.998:
                    r += 30.0
                out[y, x, c] = r
    return out


for kind in ["noisy", "shifted", "tinted", "fireflies"]:
    a, r = picture(kind), picture("reference")
    ldr = flip_evaluator.evaluate(
        numpy.clip(r, 0, 1), numpy.clip(a, 0, 1), "LDR", inputsRGB=False, applyMagma=False
    )
    hdr = flip_evaluator.evaluate(r, a, "HDR", applyMagma=False)
    p = hdr[2]
    print(
        f'("{kind}", {ldr[1]:.7f}, {hdr[1]:.7f}, '
        f'{p["startExposure"]:.5f}, {p["stopExposure"]:.5f}, {p["numExposures"]}),'
    )
