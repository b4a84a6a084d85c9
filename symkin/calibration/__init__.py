"""Calibration: identify a mechanism's geometry from joint readings and measurements of its
platform.

The way of the data, by modules:
  data       `files` and `columns` read a file, `measurements` hold it, `parameters` name what it
             may determine
  estimate   `problem` states what is fitted; `workspace`, `configurations` and `starting` find
             where to begin; `configuration_model`, `residuals` and `state` evaluate, and set
             readings beside the prior; `estimator`, `joint_lines` and `robust` minimise
  judge      `assessment` builds the `result`: `statistics`, `identifiability`;
             `outliers` finds bad readings, `mistakes` (of columns, of frames) and `trials` wrong
             files, `accuracy` judges by what these predict; `verdict` notes doubts and says what
             all of it means
  design     `simulation` makes readings, `planning` chooses configurations worth measuring
`calibrate` runs this for measurements, `fit_file` for a file, by the `options` of both, and
`report` says what came of it.
"""
