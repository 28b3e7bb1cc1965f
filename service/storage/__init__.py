"""Storage of gamuts, inputs and jobs: a local directory, or a bucket at S3, GCS or Azure."""
