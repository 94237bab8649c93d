"""Response models fitted to and judged by predictions over short windows of records.

A window starts from the state that the record itself, smoothed, has there, and is predicted with the recorded inputs
for a few ship lengths.  What a free run of minutes adds up (trim, wind, current, the first error) does not reach its
end, and a record gives many windows: structure can be judged by leaving blocks of time out.

For yaw alone and structures that are unknown: `diagnosis/craft` tries hundreds of fits, each of a second.  Where a
model is given and its numbers are asked, free runs know more (`diagnosis/free_runs`), for every state and for thrust.
"""
