// The headers that all tests have precompiled belong to a target, and a target has a source.
