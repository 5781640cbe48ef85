"""Device programs and bridges beside telespring-link: processes that import nothing of telespring."""
