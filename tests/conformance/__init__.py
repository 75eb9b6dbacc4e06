"""Every device of ours against the contract of its protocol."""
