"""Methods of torchsde as schemes of sdaeverify."""
