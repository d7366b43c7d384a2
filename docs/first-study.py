# %% [markdown]
# # Five minutes, executed
#
# This page is a program. It runs whenever the site is built, so what it prints and draws is what
# this version prints and draws. In a shell the same five steps are `lostmotion new`, `check`,
# `study`, an editor, and `study` again.
#
# ## 1. Begin with a file
#
# `new` writes an arm file that runs at once. Every value in it is marked as assumed until you state
# your own.

# %%
import tempfile
from pathlib import Path

import lostmotion

file = Path(tempfile.mkdtemp()) / "my-arm.toml"
lostmotion.new("my-arm", template="six-axis").report(file)
print(*file.read_text().splitlines()[:40], sep="\n")

# %% [markdown]
# ## 2. Check what it describes
#
# `check` samples nothing. It lists what is stated, assumed and ideal, and draws the arm from the
# side, from the front and from above.

# %%
from IPython.display import SVG

checked = lostmotion.check(file)
SVG(checked.picture)

# %% [markdown]
# ## 3. Study it
#
# One arm in its workspace, coloured by error; the arrow is the mean error at the worst pose. The
# bars name the parts that are to blame.

# %%
study = lostmotion.study(file, poses=512, robots=200, visits=10)
study

# %% [markdown]
# The same on a terminal:

# %%
study.summary()

# %% [markdown]
# ## 4. Change what is to blame
#
# The parts with the largest share of the mean square, and what halving their errors takes off the
# 95th percentile:

# %%
for part in study.costs()[:3]:
    print(
        f"{part.name:24} {100 * part.share:4.1f} %  "
        f"{1e3 * study.halving.gains[part.part].value:.3f} mm"
    )

# %% [markdown]
# A larger reducer for the first two joints, one line of the file:

# %%
text = file.read_text()
stiffer = file.with_name("stiffer.toml")
_ = stiffer.write_text(text.replace('catalogue = "RV-80E-121"', 'catalogue = "RV-110E-111"'))

# %% [markdown]
# ## 5. See what it did
#
# `compare` gives both arms the same random draws, so a change is known far more precisely than the
# two figures.

# %%
compared = lostmotion.compare(file, stiffer, poses=512, robots=200, visits=10)
compared.summary()

# %% [markdown]
# `study.report("my-report")` writes the page with every figure, `figure` returns one chart for a
# paper:

# %%
# %matplotlib inline
study.figure("waterfall")
