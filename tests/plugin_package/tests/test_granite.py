from rbs_plugins.testing import conformance

test_granite = conformance("rbs_granite")
