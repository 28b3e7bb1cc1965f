"""Where gamuts, inputs and jobs are kept: a local directory, or a bucket at S3, GCS or Azure."""
