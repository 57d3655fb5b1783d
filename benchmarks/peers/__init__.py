"""Other methods of calibration, each made to do what a `Task` asks: `calibrate(task, seed)`, a function in a file of its own.

A method may need packages that graincal does not go together with. So it may run in another Python, and speaks with the benchmark by lines of
JSON; these files need NumPy and their own method, nothing of graincal.
"""
