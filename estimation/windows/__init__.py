"""Response models fitted to and judged by predictions over short windows of records.

A window starts from the state that the record itself, smoothed, has there, and is predicted with the recorded inputs
for a few ship lengths.  What a free run of minutes adds up (trim, wind, current, the first error) does not reach its
end, and a record gives many windows: structure can be judged by leaving blocks of time out.
"""
