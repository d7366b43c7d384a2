# %% [markdown]
# # A first study, executed
#
# This page is a program. It runs whenever the site is built, so what it prints is what this version prints.

# %%
import lostmotion

arm = lostmotion.read("examples/z-arm.toml")
study = lostmotion.study(arm, poses=512, robots=200, visits=10)
study

# %% [markdown]
# The headline figures, with their 95 % confidence intervals:

# %%
study.summary()
