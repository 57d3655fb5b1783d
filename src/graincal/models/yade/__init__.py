"""YADE as a model: the paper's triaxial test, as a script that an installed `yade` runs, and scripts of the user's own."""
