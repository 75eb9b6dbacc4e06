"""The framework: plans, acquisition, tracking, reconstruction, and the bench that composes the devices."""
