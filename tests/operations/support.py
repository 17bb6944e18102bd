"""What the scripts of tests/operations share: a server process, HTTP, a WebSocket viewer. Standard library only."""
import base64, contextlib, json, os, shutil, signal, socket, ssl, struct, subprocess, sys, tempfile, time

ROOT = os.path.dirname(os.path.dirname(os.path.dirname(os.path.abspath(__file__))))
PROGRAM = os.environ.get('HELIOGRAPH', os.path.join(ROOT, 'build/release/heliograph'))
checks, failures = [], []


def check(what, good, detail=''):
    """One line a check; `finish` gives the exit code."""
    print('%s  %s%s' % ('ok  ' if good else 'FAIL', what, ' (%s)' % detail if detail != '' else ''), flush=True)
    checks.append(what)
    if not good:
        failures.append(what)
    return good


def finish():
    print('%d checks, %d failed' % (len(checks), len(failures)))
    sys.exit(1 if failures else 0)


def program(name):
    """Its path: installed, or fetched by fetch.sh. Ends the script, well, where it is not here."""
    fetched = [os.path.join(ROOT, 'out/operations/usr', folder, name) for folder in ('bin', 'sbin')]
    found = shutil.which(name) or shutil.which(name, path='/usr/sbin') or next((f for f in fetched if os.access(f, os.X_OK)), None)
    if not found:
        print('not run: %s is not here (tests/operations/fetch.sh gets it)' % name)
        finish()
    return found


def free_port():
    with contextlib.closing(socket.socket()) as s:
        s.bind(('127.0.0.1', 0))
        return s.getsockname()[1]


def until(condition, seconds=20.0):
    end = time.monotonic() + seconds
    while time.monotonic() < end:
        value = condition()
        if value:
            return value
        time.sleep(0.02)
    return None


class Server:
    """`heliograph serve` on a free port, with a folder of its own."""

    def __init__(self, *arguments, scene='cornell', environment=None, wait=True, port=0, scheme='http', client=None):
        self.folder = tempfile.TemporaryDirectory(prefix='heliograph-operations-')
        self.scheme = scheme
        self.out = open(os.path.join(self.folder.name, 'out'), 'w+b')
        self.err = open(os.path.join(self.folder.name, 'err'), 'w+b')
        command = [PROGRAM, 'serve', scene, '--listen', '127.0.0.1:%d' % port, '--client', client or client_folder(self.folder.name)]
        self.process = subprocess.Popen(command + list(arguments), stdout=self.out, stderr=self.err, stdin=subprocess.DEVNULL,
                                        cwd=self.folder.name, env={**os.environ, **(environment or {})})
        self.port = port
        if wait:
            line = until(lambda: self.printed() or self.process.poll() is not None, 60)
            if not self.printed():
                raise RuntimeError('the server did not start: ' + self.log())
            self.port = int(self.printed().rsplit(':', 1)[1])

    def printed(self):
        return self._read(self.out)

    def log(self):
        return self._read(self.err)

    @staticmethod
    def _read(file):
        with open(file.name, 'rb') as f:
            return f.read().decode('utf-8')

    def get(self, path, headers=()):
        return http(self.port, path, headers, self.scheme)

    def send(self, which):
        self.process.send_signal(which)

    def end(self, which=signal.SIGTERM):
        """Exit code and seconds."""
        start = time.monotonic()
        if self.process.poll() is None:
            self.process.send_signal(which)
        try:
            code = self.process.wait(20)
        except subprocess.TimeoutExpired:
            self.process.kill()
            code = self.process.wait()
        return code, time.monotonic() - start


def client_folder(folder):
    path = os.path.join(folder, 'client')
    os.makedirs(path, exist_ok=True)
    with open(os.path.join(path, 'index.html'), 'w') as f:
        f.write('<p>hello')
    return path


def connect(port, scheme='http', host='127.0.0.1'):
    s = socket.create_connection((host, port), 20)
    if scheme == 'https':
        context = ssl.create_default_context()
        context.check_hostname = False
        context.verify_mode = ssl.CERT_NONE
        s = context.wrap_socket(s, server_hostname='localhost')
    return s


def http(port, path, headers=(), scheme='http'):
    """Status, headers (lower case) and body."""
    with contextlib.closing(connect(port, scheme)) as s:
        lines = ['GET %s HTTP/1.1' % path, 'Host: localhost:%d' % port, 'Connection: close', *headers]
        s.sendall(('\r\n'.join(lines) + '\r\n\r\n').encode())
        data = b''
        while True:
            piece = s.recv(65536)
            if not piece:
                break
            data += piece
    head, _, body = data.partition(b'\r\n\r\n')
    lines = head.decode('latin-1').split('\r\n')
    fields = {k.strip().lower(): v.strip() for k, v in (line.split(':', 1) for line in lines[1:] if ':' in line)}
    return int(lines[0].split()[1]), fields, body.decode('utf-8', 'replace')


class Viewer:
    """A WebSocket viewer that acknowledges frames while it reads."""

    def __init__(self, port, scheme='http', path='/ws', headers=(), size=(160, 96)):
        self.socket = connect(port, scheme)
        lines = ['GET %s HTTP/1.1' % path, 'Host: localhost:%d' % port, 'Connection: Upgrade', 'Upgrade: websocket',
                 'Sec-WebSocket-Version: 13', 'Sec-WebSocket-Key: ' + base64.b64encode(os.urandom(16)).decode(),
                 'Sec-WebSocket-Protocol: heliograph.v1', *headers]
        self.socket.sendall(('\r\n'.join(lines) + '\r\n\r\n').encode())
        self.data = b''
        while b'\r\n\r\n' not in self.data:
            piece = self.socket.recv(4096)
            if not piece:
                raise RuntimeError('no answer to the upgrade')
            self.data += piece
        head, self.data = self.data.split(b'\r\n\r\n', 1)
        self.status = int(head.split()[1])
        self.texts, self.inputs, self.closed = [], [], None
        if self.status == 101:
            self.say(type='resolution', width=size[0], height=size[1], inputId=1)

    def say(self, **message):
        payload = json.dumps(message).encode()
        mask = os.urandom(4)
        head = bytes([0x81]) + (bytes([0x80 | len(payload)]) if len(payload) < 126 else bytes([0xfe]) + struct.pack('>H', len(payload)))
        self.socket.sendall(head + mask + bytes(b ^ mask[i % 4] for i, b in enumerate(payload)))

    def camera(self, input_id, moving=False):
        self.say(type='camera', inputId=input_id, position=[0.01 * (input_id % 50), 1, 3], forward=[0, 0, -1], up=[0, 1, 0],
                 fieldOfView=60, moving=moving)

    def _take(self, count, end):
        while len(self.data) < count:
            self.socket.settimeout(max(0.01, end - time.monotonic()))
            piece = self.socket.recv(65536)
            if not piece:
                raise EOFError
            self.data += piece
        taken, self.data = self.data[:count], self.data[count:]
        return taken

    def read(self, seconds, stop=lambda: False, acknowledge=True):
        """Reads messages until the time is over, the connection ends or `stop()`."""
        end = time.monotonic() + seconds
        try:
            while time.monotonic() < end and not stop():
                first, second = self._take(2, end)
                length = second & 127
                if length > 125:
                    length = int.from_bytes(self._take(2 if length == 126 else 8, end), 'big')
                payload = self._take(length, end)
                kind = first & 15
                if kind == 8:
                    self.closed = int.from_bytes(payload[:2], 'big')
                    return
                self.take(kind, payload, acknowledge)
        except (socket.timeout, TimeoutError, EOFError, ConnectionError):
            return

    def take(self, kind, payload, acknowledge):
        """A message that was read: text (kind 1) or a frame (2)."""
        if kind == 1:
            self.texts.append(json.loads(payload))
        if kind == 2 and payload[2] == 1:
            self.inputs.append(struct.unpack_from('<I', payload, 12)[0])
            if acknowledge:
                self.say(type='ack', frameId=struct.unpack_from('<I', payload, 8)[0], presentedMs=10.0)
