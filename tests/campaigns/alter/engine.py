"""The random numbers of C++: std::mt19937_64 and the distributions of libstdc++, so that draws are those of earlier measurements."""
import math

N, M, MASK = 312, 156, (1 << 64) - 1
UPPER, LOWER = 0xFFFFFFFF80000000, 0x7FFFFFFF


class Engine:
    """Mersenne Twister of 64 bits (Nishimura 2000)."""

    def __init__(self, seed):
        self.state, self.at, self.saved = [seed & MASK], N, None
        for i in range(1, N):
            last = self.state[-1]
            self.state.append((6364136223846793005 * (last ^ (last >> 62)) + i) & MASK)

    def __call__(self):
        if self.at == N:
            s = self.state
            for i in range(N):
                x = (s[i] & UPPER) | (s[(i + 1) % N] & LOWER)
                s[i] = s[(i + M) % N] ^ (x >> 1) ^ (0xB5026F5AA96619E9 if x & 1 else 0)
            self.at = 0
        x = self.state[self.at]
        self.at += 1
        x ^= (x >> 29) & 0x5555555555555555
        x ^= (x << 17) & 0x71D67FFFEDA60000
        x ^= (x << 37) & 0xFFF7EEE000000000
        return x ^ (x >> 43)

    def below(self, count):
        return self() % max(1, count)

    def index(self, count):
        """Returns a whole number below `count` (Lemire 2019)."""
        product = self() * count
        if product & MASK < count:
            while product & MASK < (-count & MASK) % count:
                product = self() * count
        return product >> 64

    def uniform(self):
        """Returns a number in [0, 1)."""
        return self() / 2.0**64

    def normal(self, sigma=1.0):
        """Polar method of Marsaglia. It makes two numbers at once."""
        if self.saved is not None:
            value, self.saved = self.saved, None
            return value * sigma
        while True:
            x, y = 2 * self.uniform() - 1, 2 * self.uniform() - 1
            square = x * x + y * y
            if 0 < square <= 1:
                break
        factor = math.sqrt(-2 * math.log(square) / square)
        self.saved = x * factor
        return y * factor * sigma
