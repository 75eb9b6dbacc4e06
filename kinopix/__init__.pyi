from instrument import *
