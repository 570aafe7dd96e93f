class TensorRowLoops: pass
