"""Laboratory files by closed-form curves, with what is right to read from each: see `curves` for the physics, `choice` and `deprived` for what is varied.

python -m tests.laboratory.generated DIR            all files in DIR, with expectations.json
python -m tests.laboratory.generated --case 17      one case: file, options, expectation and outcome
python -m tests.laboratory.generated --run          the outcomes of all, counted
"""
