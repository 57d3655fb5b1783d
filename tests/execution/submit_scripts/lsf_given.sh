#!/bin/bash

#BSUB -W 120
#BSUB -J parsl.graincal-1.block-0
#BSUB -o /campaign/parsl/000/submit_scripts/parsl.graincal-1.block-0.submit.stdout
#BSUB -e /campaign/parsl/000/submit_scripts/parsl.graincal-1.block-0.submit.stderr
#BSUB -rn
#BSUB -R "rusage[mem=32GB]"
#BSUB -R 'select[avx512]'
#BSUB -P soil
#BSUB -q fast
#BSUB -n 16
#BSUB -R "span[ptile=16]"


module load yade

export JOBNAME="parsl.graincal-1.block-0"

exec the-workers

# submitted by: bsub 
