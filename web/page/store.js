// What the page keeps in the storage of the browser: preferences as the text of the file that the
// desktop has, and the last recordings. Where there is no storage nothing is kept.
const PREFERENCES = 'msd.preferences';
// The oldest recordings make room for new ones beyond this many.
const MOST = 20;

export function preferences() {
  try {
    return localStorage.getItem(PREFERENCES) ?? undefined;
  } catch {
    return undefined;
  }
}

export function keepPreferences(text) {
  try {
    localStorage.setItem(PREFERENCES, text);
  } catch {
    // Full, or not allowed here.
  }
}

const result = request => new Promise((done, failed) => {
  request.onsuccess = () => done(request.result);
  request.onerror = () => failed(request.error);
});

async function store(mode) {
  const request = indexedDB.open('msd', 1);
  request.onupgradeneeded = () => request.result.createObjectStore('recordings', { autoIncrement: true });
  const base = await result(request);
  const transaction = base.transaction('recordings', mode);
  transaction.oncomplete = () => base.close();
  return transaction.objectStore('recordings');
}

export async function keepRecording(name, bytes) {
  const recordings = await store('readwrite');
  await result(recordings.add({ name, bytes, date: Date.now() }));
  const keys = await result(recordings.getAllKeys());
  for (const key of keys.slice(0, -MOST)) recordings.delete(key);
}

// The recordings that are kept, the newest first: key, name and date.
export async function recordings() {
  const kept = await store('readonly');
  const [keys, rows] = await Promise.all([result(kept.getAllKeys()), result(kept.getAll())]);
  return rows.map(({ name, date }, row) => ({ key: keys[row], name, date })).reverse();
}

export async function recording(key) {
  return result((await store('readonly')).get(key));
}
