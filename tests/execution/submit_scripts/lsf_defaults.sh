#!/bin/bash

#BSUB -W 60
#BSUB -J parsl.graincal-1.block-0
#BSUB -o /campaign/parsl/000/submit_scripts/parsl.graincal-1.block-0.submit.stdout
#BSUB -e /campaign/parsl/000/submit_scripts/parsl.graincal-1.block-0.submit.stderr
#BSUB -rn
#BSUB -n 8
#BSUB -R "span[ptile=8]"




export JOBNAME="parsl.graincal-1.block-0"

exec the-workers

# submitted by: bsub 
