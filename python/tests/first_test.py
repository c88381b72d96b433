"""The package is there and solves."""
import unittest

import orasp


class First(unittest.TestCase):
    def test_solves_hubble(self) -> None:
        result = orasp.solve("hubble")
        self.assertEqual(result.status, "optimal")
        self.assertAlmostEqual(result.reward, -0.9902, places=9)

    def test_says_what_is_wrong(self) -> None:
        with self.assertRaisesRegex(orasp.InputError, "unknown method"):
            orasp.solve("hubble", method="nonsense")


if __name__ == "__main__":
    unittest.main()
