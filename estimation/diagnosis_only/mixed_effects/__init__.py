"""Free runs fitted to several records at once, with effects that each record has of its own.

A free run uses nothing of a record but its inputs, its measured wind and its initial state.  Numbers of the model
(coefficients or constants) have Gaussian priors and are common to all records.  Every record has a deviation of its
neutral rudder angle and of its initial state, with priors too: without them the coefficients would absorb the trim of
single runs.

The criterion is the sum over channels of N_eff / 2 log(S_c + floor_c^2), S_c being the mean squared error of all
records and N_eff the records' duration over the correlation time of the residuals, plus half the squares of all numbers
in prior standard deviations.  Measured thrust counts with a fixed standard deviation, N_eff S_c / (2 sd_c^2).
Gauss-Newton steps eliminate the records' own effects by a Schur complement; leaving a record out subtracts its part of
the normal equations and takes one step.

For a model that is given, near enough that a free run of minutes follows the record.  Where nothing is known of the
craft, fits to free runs end in absurd minima: `estimation/diagnosis_only/windows` fits predictions over a few ship
lengths.
"""
